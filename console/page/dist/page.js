// With preact and @preact/signals, MIT licence: see THIRD-PARTY.txt beside the sources of this page.
var n,t,r,u,i,f,o,e,l,c,a,s,h=Symbol.for("pv"),p={},y=[],v=/^m(i|n|o|s|text|space)$/,w=Array.isArray,d=y.slice,_=Object.assign;function g(n3){n3&&n3.parentNode&&
n3.remove()}function k(n3,t5,r4){var u4,i4,f5,o5={},e4=arguments.length;for(f5 in t5)f5=="key"?u4=t5[f5]:f5=="ref"&&typeof n3!="function"?i4=t5[f5]:o5[f5]=t5[f5];
return e4>2&&(o5.children=e4>3?d.call(arguments,2):r4),m(n3,o5,u4,i4,null)}function m(r4,u4,i4,f5,o5){var e4={type:r4,props:u4,key:i4,ref:f5,__k:null,__:null,__b:0,__e:null,__c:null,constructor:h,__v:o5||++t,__i:-1,__u:0};return!o5&&n.
vnode&&n.vnode(e4),e4}function $(n3){return n3.children}function x(n3,t5){this.props=n3,this.context=t5,this.__g=0}function S(n3,t5){if(t5==null)return n3.__&&S(n3.__,n3.__i+1);for(var r4;t5<
n3.__k.length;t5++)if((r4=n3.__k[t5])&&r4.__e)return r4.__e;return typeof n3.type!="function"||n3.props.__P?null:S(n3)}function C(t5){var r4,u4=t5.__v,i4=u4.__e,
f5=[],o5=[],e4=t5.__P;e4&&((r4=_({constructor:h},u4)).__v=u4.__v+1,n.vnode&&n.vnode(r4),z(e4,r4,u4,t5.__n,e4.namespaceURI,32&u4.__u?[i4]:null,f5,i4||S(u4),32&u4.
__u,o5),r4.__v=u4.__v,r4.__.__k[r4.__i]=r4,E(f5,r4,o5),u4.__=u4.__e=null,r4.__e!=i4&&j(r4))}function j(n3){if((n3=n3.__)&&n3.__c&&!n3.props.__P)return n3.__e=null,
n3.__k.some(function(t5){return t5&&(n3.__e=t5.__e)}),j(n3)}function L(t5){(8&t5.__g||(t5.__g|=8,u.push(t5),f++))&&i==n.debounceRendering||((i=n.debounceRendering)||
queueMicrotask)(H)}function H(){try{for(var n3,t5=1;u.length;)u.length>t5&&u.sort(o),n3=u.shift(),t5=u.length,8&n3.__g&&C(n3)}finally{(f=u.length)&&(i||queueMicrotask)(
H)}}function I(n3,t5,r4,u4,i4,f5,o5,e4,l4,c4,a5){var s4,h5,v4,w5,d4,_3,g5=u4.__k||y,k4=t5.length;for(l4=q(r4,t5,g5,l4,k4),s4=0;s4<k4;s4++)(v4=r4.__k[s4])!=null&&
(h5=~v4.__i&&g5[v4.__i]||p,v4.__i=s4,_3=z(n3,v4,h5,i4,f5,o5,e4,l4,c4,a5),w5=v4.__e,(h5.ref!=v4.ref||8&h5.__u)&&(h5.ref&&G(h5.ref,null,v4,h5),v4.ref&&a5.push(v4.
ref,v4.__c||w5,v4)),d4=d4||w5,4&v4.__u?(l4=A(v4,l4,n3,!h5.__v),h5.__e&&(h5.__e=null)):typeof v4.type=="function"&&_3!==void 0?l4=_3:w5&&(l4=w5.nextSibling),v4.__u&=
-21);return r4.__e=d4,l4}function q(n3,t5,r4,u4,i4){var f5,o5,e4,l4,c4,a5,s4,p5,y5,v4=r4.length,d4=v4,_3=0,g5=0,k4=n3.__k=Array(i4);for(f5=0;f5<i4;f5++)(o5=t5[f5])!=
null&&typeof o5!="boolean"&&typeof o5!="function"?(typeof o5!="object"||o5.constructor===String?o5=k4[f5]=m(null,o5):w(o5)?o5=k4[f5]=m($,{children:o5}):o5.constructor===
h&&o5.__b?o5=k4[f5]=m(o5.type,o5.props,o5.key,o5.ref,o5.__v):k4[f5]=o5,l4=f5+_3,o5.__=n3,o5.__b=n3.__b+1,e4=null,~(c4=o5.__i=P(o5,r4,l4,d4))&&(d4--,(e4=r4[c4])&&
(e4.__u|=2)),e4&&e4.__v?(o5.__u|=16,c4==l4-1?_3--:c4==l4+1?_3++:c4!=l4&&(c4>l4?_3--:_3++,g5=1)):(~c4||(i4>v4?_3--:i4<v4&&_3++),typeof o5.type!="function"&&(o5.__u|=
4))):k4[f5]=null;if(g5){for(a5=[],s4=[],f5=0;f5<i4;f5++)if((o5=k4[f5])&&16&o5.__u){for(_3=0,p5=a5.length;_3<p5;)a5[y5=_3+p5>>1]<o5.__i?_3=y5+1:p5=y5;a5[_3]=o5.__i,
s4[f5]=_3+1}for(_3=a5.length;f5--;)s4[f5]&&(s4[f5]==_3?_3--:k4[f5].__u|=4)}if(d4)for(f5=0;f5<v4;f5++)!(e4=r4[f5])||2&e4.__u||(e4.__e==u4&&(u4=S(e4)),J(e4,e4));return u4}
function A(n3,t5,r4,u4){var i4,f5,o5,e4;if(typeof n3.type=="function"){if(n3.props.__P)return t5;if(i4=n3.__k)for(f5=0;f5<i4.length;f5++)i4[f5]&&(i4[f5].__=n3,t5=
A(i4[f5],t5,r4,!1));return t5}for(t5&&!t5.parentNode&&(t5=S(n3))&&!t5.parentNode&&(t5=null),o5=n3.__e,e4=t5;e4&&e4.nodeType==8;)e4=e4.nextSibling;for(o5!=e4&&(!u4&&
r4.moveBefore&&o5.parentNode?r4.moveBefore(o5,t5):r4.insertBefore(o5,t5||null)),t5=o5;(t5=t5&&t5.nextSibling)&&t5.nodeType==8&&!t5.data.startsWith("$s"););return t5}function P(n3,t5,r4,u4){var i4,f5=n3.key,o5=n3.type,e4=t5[r4],l4=e4&&!(2&e4.__u);if(e4===null&&f5==null||l4&&f5==e4.key&&o5==e4.type)return r4;if(u4>(l4?1:0)){for(i4=
r4-1;i4>=0;i4--)if((e4=t5[i4])&&!(2&e4.__u)&&f5==e4.key&&o5==e4.type)return i4;for(i4=r4+1;i4<t5.length;i4++)if((e4=t5[i4])&&!(2&e4.__u)&&f5==e4.key&&o5==e4.type)
return i4}return-1}function T(n3,t5,r4){r4==null&&(r4=""),t5[0]=="-"?n3.setProperty(t5,r4):n3[t5]=r4}function N(n3,t5,r4,u4,i4){var f5,o5;if(t5=="style")if(typeof r4==
"string")n3.style.cssText=r4;else{if(typeof u4=="string"&&(n3.style.cssText=u4=""),u4)for(t5 in u4)r4&&t5 in r4||T(n3.style,t5);if(r4)for(t5 in r4)u4&&r4[t5]==u4[t5]||
T(n3.style,t5,r4[t5])}else if(t5[0]=="o"&&t5[1]=="n")typeof r4!="function"&&(r4=null),typeof u4!="function"&&(u4=null),(n3.__e||(n3.__e={}))[t5]=r4,r4&&u4||(o5=
a[t5]||(a[t5]=V(t5)),(n3.__a||(n3.__a={}))[t5]=c,f5=t5!=(t5=t5.replace(l,"$1")),(t5=t5.slice(2))[0]<"a"&&(t5=t5.toLowerCase()),r4?n3.addEventListener(t5,o5,f5):
n3.removeEventListener(t5,o5,f5));else{if(i4=="http://www.w3.org/2000/svg")t5=t5.replace(/xlink(H|:h)/,"h").replace(/sName$/,"s");else if(t5!="width"&&t5!="heig\
ht"&&t5!="href"&&t5!="list"&&t5!="form"&&t5!="tabIndex"&&t5!="download"&&t5!="rowSpan"&&t5!="colSpan"&&t5!="role"&&t5!="popover"&&t5 in n3)try{return void(n3[t5]=
r4??"")}catch{}if(typeof r4=="function")return;r4==null||r4===!1&&t5[4]!="-"?n3.removeAttribute(t5):n3.setAttribute(t5,t5=="popover"&&r4==1?"":r4)}}function V(t5){
return function(r4){var u4=this.__e;if(u4){if(u4=u4[t5],r4[e]==null)r4[e]=c++;else if(r4[e]<this.__a[t5])return;return u4(n.event?n.event(r4):r4)}}}function z(t5,r4,u4,i4,f5,o5,e4,l4,c4,a5){
var s4,p5,v4,d4,k4,b3,m5,M2,C3,j3,L2,H2,q2,A4,O2,P2,T4,N2,V2=r4.type;if(r4.constructor!==h)return null;128&u4.__u&&(c4=32&u4.__u,s4=u4.__c.__z)&&(r4.__u|=c4,p5=
o5=[],s4.nodeType==8?l4=B(s4,o5):o5.push(s4),l4=o5[0]||l4),(s4=n.__b)&&s4(r4);n:if(typeof V2=="function"){v4=e4.length;try{if(M2=r4.props,C3=(s4=V2.prototype)&&
s4.render,j3=(s4=V2.contextType)&&i4[s4.__c],L2=s4?j3?j3.props.value:s4.__:i4,(d4=u4.__c)?(r4.__c=d4,2&d4.__g&&(d4.__g|=1)):(C3?r4.__c=d4=new V2(M2,L2):(r4.__c=
d4=new x(M2,L2),d4.constructor=V2,d4.render=K),j3&&j3.sub(d4),d4.state||(d4.state={}),d4.__n=i4,d4.__g|=8,d4.__h=[],d4.__k=[]),C3&&(d4.__s||(d4.__s=d4.state),V2.
getDerivedStateFromProps&&(d4.__s==d4.state&&(d4.__s=_({},d4.__s)),_(d4.__s,V2.getDerivedStateFromProps(M2,d4.__s)))),k4=d4.props,b3=d4.state,d4.__v=r4,u4.__c){
if(M2!==k4&&C3&&!V2.getDerivedStateFromProps&&d4.componentWillReceiveProps&&d4.componentWillReceiveProps(M2,L2),r4.__v==u4.__v&&!(8&d4.__g)||!(4&d4.__g)&&d4.shouldComponentUpdate&&
d4.shouldComponentUpdate(M2,d4.__s,L2)===!1){r4.__v!=u4.__v&&(d4.props=M2,d4.state=d4.__s,d4.__g&=-9),r4.__e=u4.__e,r4.__k=u4.__k,r4.__k.some(function(n3){n3&&(n3.
__=r4)}),y.push.apply(d4.__h,d4.__k),d4.__k=[],d4.__h.length&&e4.push(d4),l4=S(u4);break n}d4.componentWillUpdate&&d4.componentWillUpdate(M2,d4.__s,L2),C3&&d4.componentDidUpdate&&
d4.__h.push(function(){d4.componentDidUpdate(k4,b3,m5)})}else C3&&!V2.getDerivedStateFromProps&&d4.componentWillMount&&d4.componentWillMount(),C3&&d4.componentDidMount&&
d4.__h.push(d4.componentDidMount);d4.context=L2,d4.props=M2,d4.__P=t5,d4.__g&=-5,H2=n.__r,q2=C3?25:0;do d4.__g&=-9,H2&&H2(r4),s4=d4.render(d4.props,d4.state=d4.
__s,d4.context);while(8&d4.__g&&++q2<25);C3&&(y.push.apply(d4.__h,d4.__k),d4.__k=[]),d4.state=d4.__s,d4.getChildContext&&(i4=_({},i4,d4.getChildContext())),C3&&
u4.__c&&d4.getSnapshotBeforeUpdate&&(m5=d4.getSnapshotBeforeUpdate(k4,b3)),A4=s4&&s4.type===$&&s4.key==null?s4.props.children:s4,M2.__P&&(s4=l4,f5=(t5=M2.__P).namespaceURI,
c4=o5=null,u4.props&&u4.props.__P!=t5&&(u4.__k.some(function(n3){n3&&J(n3,n3)}),u4.__k=null),l4=u4.__k?S(u4,0):null),l4=I(t5,w(A4)?A4:[A4],r4,u4,i4,f5,o5,e4,l4,
c4,a5),M2.__P&&(r4.__e=null,l4=s4),r4.__u&=-161,p5&&p5.some(g),d4.__h.length&&e4.push(d4),1&d4.__g&&(d4.__g&=-4)}catch(t6){if(e4.length=v4,r4.__v=null,c4||o5)if(t6&&
t6.then){if(r4.__u|=128|c4,o5){for(~(T4=o5.indexOf(l4||void 0))||(T4=o5.length);(N2=o5[T4-1])&&N2.nodeType==8;)T4--;for(;T4<o5.length;T4++)if(N2=o5[T4])if(o5[T4]=
null,O2){if(N2==P2)break}else{if(N2.nodeType!=8)break;N2.data.startsWith("$s")&&(P2=B(O2=N2))}}if(!O2){for(;l4&&l4.nodeType==8&&l4.nextSibling;)l4=l4.nextSibling;
O2=l4}(s4=B(O2=r4.__c.__z||(r4.__c.__z=O2)))?(r4.__e=O2,l4=s4):r4.__e=l4,l4=l4&&l4.nextSibling}else o5&&o5.some(g);else r4.__e=u4.__e;r4.__k||(r4.__k=u4.__k||[]),
t6&&t6.then||D(r4),n.__e(t6,r4,u4)}}else l4=r4.__e=F(u4.__e,r4,u4,i4,f5,o5,e4,c4,a5,t5);return(s4=n.diffed)&&s4(r4),l4}function B(n3,t5){if(n3&&n3.nodeType==8&&
n3.data.startsWith("$s"))for(var r4=1;n3=n3.nextSibling;){if(n3.nodeType==8){if(n3.data.startsWith("$s"))r4++;else if(n3.data.startsWith("/$s")&&!--r4)return n3}
t5&&t5.push(n3)}}function D(n3){n3&&(n3.__c&&(n3.__c.__g|=4),n3.__k&&n3.__k.some(D))}function E(t5,r4,u4){for(var i4=0;i4<u4.length;)G(u4[i4++],u4[i4++],u4[i4++]);
n.__c&&n.__c(r4,t5),t5.some(function(r5){try{t5=r5.__h,r5.__h=[],t5.some(function(n3){n3.call(r5)})}catch(t6){n.__e(t6,r5.__v)}})}function F(t5,r4,u4,i4,f5,o5,e4,l4,c4,a5){
var s4,h5,y5,_3,k4,b3,m5,M2,$2=u4.props||p,x3=r4.props,C3=r4.type;if(C3=="svg"?f5="http://www.w3.org/2000/svg":C3=="math"?f5="http://www.w3.org/1998/Math/MathML":
f5||(f5="http://www.w3.org/1999/xhtml"),o5){for(s4=0;s4<o5.length;s4++)if((k4=o5[s4])&&(C3?k4.localName==C3:k4.nodeType==3)){t5=k4,o5[s4]=null;break}}if(!t5){if(M2=
a5.ownerDocument||document,!C3)return M2.createTextNode(x3);t5=M2.createElementNS(f5,C3,x3.is?x3:a5),l4&&(n.__m&&n.__m(r4,o5),l4=!1),o5=null}if(C3){if(a5=C3=="t\
emplate"&&t5.content||t5,o5=C3=="textarea"&&x3.defaultValue!=null?null:o5&&d.call(a5.childNodes),!l4&&o5)for($2={},s4=0;s4<t5.attributes.length;s4++)$2[(k4=t5.attributes[s4]).
name]=k4.value;for(s4 in $2)k4=$2[s4],s4=="dangerouslySetInnerHTML"?y5=k4:s4=="children"||s4 in x3||s4=="value"&&"defaultValue"in x3||s4=="checked"&&"defaultChe\
cked"in x3||N(t5,s4,null,k4,f5);for(s4 in x3)k4=x3[s4],s4=="children"?_3=k4:s4=="dangerouslySetInnerHTML"?h5=k4:s4=="value"?b3=k4:s4=="checked"?m5=k4:l4&&typeof k4!=
"function"||$2[s4]===k4||N(t5,s4,k4,$2[s4],f5);h5?(l4||y5&&(h5.__html==y5.__html||h5.__html==t5.innerHTML)||(t5.innerHTML=h5.__html),r4.__k=[]):(y5&&(t5.textContent=
""),(C3=="foreignObject"||f5=="http://www.w3.org/1998/Math/MathML"&&v.test(C3))&&(f5="http://www.w3.org/1999/xhtml"),I(a5,w(_3)?_3:[_3],r4,u4,i4,f5,o5,e4,o5?o5[0]:
u4.__k&&S(u4,0),l4,c4),o5&&o5.some(g)),l4&&C3!="textarea"||(s4="value",C3=="progress"&&b3==null?t5.removeAttribute(s4):b3==null||b3===t5[s4]&&(C3!="progress"||b3)||
N(t5,s4,b3,$2[s4],f5),s4="checked",m5!=null&&m5!=t5[s4]&&N(t5,s4,m5,$2[s4],f5))}else $2===x3||l4&&t5.data==x3||(t5.data=x3);return t5}function G(t5,r4,u4,i4){try{
typeof t5=="function"?r4?r4.__x=t5(r4)||1:i4&&(i4=i4.__c||i4.__e)&&(r4=i4.__x)&&(i4.__x=null,typeof r4=="function"?r4():t5(null)):t5.current=r4}catch(t6){n.__e(
t6,u4)}}function J(t5,r4,u4){var i4,f5,o5,e4;if(n.unmount&&n.unmount(t5),!(i4=t5.ref)||i4.current&&i4.current!=t5.__e||G(i4,null,r4,t5),i4=t5.__c){if(i4.componentWillUnmount)
try{i4.componentWillUnmount()}catch(t6){n.__e(t6,r4)}i4.__P=i4.__n=null}if(i4=t5.__k)for(e4=0;e4<i4.length;e4++)i4[e4]&&J(i4[e4],r4,typeof t5.type!="function"||
u4&&!t5.props.__P);!u4&&(i4=t5.__c)&&(i4=i4.__z)&&(f5=B(i4,o5=[]))&&(i4==t5.__e&&o5.some(g),g(f5),g(i4)),u4||g(t5.__e),t5.__e=t5.__c=t5.__=null}function K(n3,t5,r4){
return this.constructor(n3,r4)}function Q(t5,r4){var u4,i4,f5,o5;n.__&&n.__(t5,r4),r4.nodeType==9&&(r4=r4.documentElement),i4=(u4=t5&&32&t5.__u)?null:r4.__k,r4.
__k=m($,{children:[t5]}),f5=[],o5=[],z(r4,r4.__k,i4||p,p,r4.namespaceURI,i4?null:r4.firstChild?d.call(r4.childNodes):null,f5,i4?i4.__e:r4.firstChild,u4,o5),E(f5,
r4.__k,o5),r4.__k.props.children=null}n={__e:function(n3,t5,r4,u4){for(var i4,o5,e4;t5=t5.__;)if((i4=t5.__c)&&!(1&i4.__g)){i4.__g|=4;try{if((e4=(o5=i4.constructor)&&o5.getDerivedStateFromError)&&i4.
setState(o5.getDerivedStateFromError(n3)),i4.componentDidCatch&&(i4.componentDidCatch(n3,u4||{}),e4=1),e4&&8&i4.__g)return void(i4.__g|=2)}catch(t6){n3=t6}}throw f=
0,n3}},t=0,r=function(n3){return n3!=null&&n3.constructor===h},x.prototype.setState=function(n3,t5){var r4=this.__s;r4&&r4!=this.state||(r4=this.__s=_({},this.state)),
typeof n3=="function"&&(n3=n3(_({},r4),this.props)),n3&&(_(r4,n3),this.__v&&(t5&&this.__k.push(t5),L(this)))},x.prototype.forceUpdate=function(n3){this.__v&&(this.
__g|=4,n3&&this.__h.push(n3),L(this))},x.prototype.render=$,u=[],f=0,o=function(n3,t5){return n3.__v.__b-t5.__v.__b},e=Symbol(),l=/(PointerCapture)$|Capture$/i,
c=0,a={},s=0;var t2,r2,u2,i2,o2=Object.is,f2=0,c2=[],e2=[],a2=n,v2=a2.__b,l2=a2.__r,m2=a2.diffed,h2=a2.__c,s2=a2.unmount,p2=a2.__;function y2(n3,t5){a2.__h&&a2.__h(r2,n3,f2||
t5),f2=0;var u4=r2.__H||(r2.__H={__:[],__h:[]});return n3>=u4.__.length&&u4.__.push({}),u4.__[n3]}function F2(n3,u4){var i4=y2(t2++,4);!a2.__s&&E2(i4.__H,u4)&&(i4.__P=!1,i4.__=n3,i4.u=u4,r2.__h.push(i4))}function w2(n3,r4){var u4=y2(t2++,7);return E2(u4.__H,r4)&&(u4.__=n3(),u4.__H=r4),u4.__}function g2(){var n3;do{for(;n3=e2.shift();)try{C2(n3)}catch(t6){a2.__e(t6,{__:(n3=n3.__P)&&n3.__v})}for(;n3=c2.shift();){var t5=n3.__H;if(n3.__P&&t5)try{t5.__h.
some(C2),t5.__h.some(D2),t5.__h=[]}catch(r4){t5.__h=[],a2.__e(r4,n3.__v)}}}while(e2.length)}a2.__b=function(n3){r2=null,v2&&v2(n3)},a2.__=function(n3,t5){n3&&t5.
__k&&t5.__k.__m&&(n3.__m=t5.__k.__m),p2&&p2(n3,t5)},a2.__r=function(n3){l2&&l2(n3),t2=0;var i4=(r2=n3.__c).__H;i4&&(u2==r2?r2.__h=[]:(i4.__h.some(C2),i4.__h.some(
D2),t2=0),i4.__h=[],i4.__.some(function(n4){n4.__N&&(n4.__=n4.__N),n4.u=n4.__N=void 0})),u2=r2},a2.diffed=function(n3){m2&&m2(n3);var t5=n3.__c;t5&&t5.__H&&(t5.
__H.__h.length&&B2(c2.push(t5)),t5.__H.__.some(function(n4){n4.u&&(n4.__H=n4.u)})),u2=r2=null},a2.__c=function(n3,t5){t5.some(function(n4){try{n4.__h.some(C2),n4.
__h=n4.__h.filter(function(n5){return!n5.__||D2(n5)})}catch(t6){n4.__h=[function(){throw t6}]}}),h2&&h2(n3,t5)},a2.unmount=function(n3){s2&&s2(n3);var t5,r4,u4=n3.
__c;u4&&u4.__H&&(u4.__H.__.some(function(u5){try{if(u5.__P&&u5.__c){if(r4===void 0){for(r4=n3.__;r4&&(!r4.__c||!r4.__c.__P);)r4=r4.__;r4=r4&&r4.__c}u5.__P=r4,B2(
e2.push(u5))}else C2(u5)}catch(n4){t5=n4}}),u4.__H=void 0,t5&&a2.__e(t5,u4.__v))};var k2=typeof requestAnimationFrame=="function";function z2(n3){var t5,r4=function(){
clearTimeout(u4),k2&&cancelAnimationFrame(t5),setTimeout(n3)},u4=setTimeout(r4,35);k2&&(t5=requestAnimationFrame(r4))}function B2(n3){n3!=1&&i2==a2.requestAnimationFrame||
((i2=a2.requestAnimationFrame)||z2)(g2)}function C2(n3){var t5=r2,u4=n3.__c;typeof u4=="function"&&(n3.__c=void 0,u4()),r2=t5}function D2(n3){var t5=r2;n3.__c=n3.
__(),r2=t5}function E2(n3,t5){return!n3||n3.length!=t5.length||t5.some(function(t6,r4){return!o2(t6,n3[r4])})}var i3=Symbol.for("preact-signals");function t3(){if(v3>1)v3--;else{var i4,t5=!1;for((function(){var i5=c3;for(c3=void 0;i5!==void 0;){var t6=i5.S;if(t6.v===i5.
v)for(var r5=t6.t;r5!==void 0;r5=r5.x)r5.i===i5.i&&(r5.i=t6.i);i5=i5.o}})();h3!==void 0;){var r4=h3;for(h3=void 0,s3++;r4!==void 0;){var n3=r4.u;if(r4.u=void 0,
r4.f&=-3,!(8&r4.f)&&w3(r4))try{r4.c()}catch(r5){t5||(i4=r5,t5=!0)}r4=n3}}if(s3=0,v3--,t5)throw i4}}function r3(i4){if(v3>0)return i4();u3=++e3,v3++;try{return i4()}finally{
t3()}}var n2,o3=void 0;function f3(i4){var t5=o3,r4=n2;o3=void 0,n2=void 0;try{return i4()}finally{o3=t5,n2=r4}}var h3=void 0,v3=0,s3=0,e3=0,u3=0,c3=void 0,a3=0;
function d2(i4){if(o3!==void 0){var t5=i4.n;if(t5===void 0||t5.t!==o3)return t5={i:0,S:i4,p:o3.s,n:void 0,t:o3,e:void 0,x:void 0,r:t5},o3.s!==void 0&&(o3.s.n=t5),
o3.s=t5,i4.n=t5,32&o3.f&&i4.S(t5),t5;if(t5.i===-1)return t5.i=0,t5.n!==void 0&&(t5.n.p=t5.p,t5.p!==void 0&&(t5.p.n=t5.n),t5.p=o3.s,t5.n=void 0,o3.s.n=t5,o3.s=t5),
t5}}function l3(i4,t5){this.v=i4,this.i=0,this.n=void 0,this.t=void 0,this.l=0,this.W=t5?.watched,this.Z=t5?.unwatched,this.name=t5?.name}l3.prototype.brand=i3;
l3.prototype.h=function(){return!0};l3.prototype.S=function(i4){var t5=this,r4=this.t;r4!==i4&&i4.e===void 0&&(i4.x=r4,this.t=i4,r4!==void 0?r4.e=i4:f3(function(){
var i5;(i5=t5.W)==null||i5.call(t5)}))};l3.prototype.U=function(i4){var t5=this;if(this.t!==void 0){var r4=i4.e,n3=i4.x;r4!==void 0&&(r4.x=n3,i4.e=void 0),n3!==
void 0&&(n3.e=r4,i4.x=void 0),i4===this.t&&(this.t=n3,n3===void 0&&f3(function(){var i5;(i5=t5.Z)==null||i5.call(t5)}))}};l3.prototype.subscribe=function(i4){var t5=this;
return x2(function(){var r4=t5.value;f3(function(){return i4(r4)})},{name:"sub"})};l3.prototype.valueOf=function(){return this.value};l3.prototype.toString=function(){
return this.value+""};l3.prototype.toJSON=function(){return this.value};l3.prototype.peek=function(){var i4=this;return f3(function(){return i4.value})};Object.
defineProperty(l3.prototype,"value",{get:function(){var i4=d2(this);return i4!==void 0&&(i4.i=this.i),this.v},set:function(i4){if(i4!==this.v){if(s3>100)throw new Error(
"Cycle detected");(function(i5){v3!==0&&s3===0&&i5.l!==u3&&(i5.l=u3,c3={S:i5,v:i5.v,i:i5.i,o:c3})})(this),this.v=i4,this.i++,a3++,v3++;try{for(var r4=this.t;r4!==
void 0;r4=r4.x)r4.t.N()}finally{t3()}}}});function y3(i4,t5){return new l3(i4,t5)}function w3(i4){for(var t5=i4.s;t5!==void 0;t5=t5.n)if(t5.S.i!==t5.i||!t5.S.h()||
t5.S.i!==t5.i)return!0;return!1}function b(i4){for(var t5=i4.s;t5!==void 0;t5=t5.n){var r4=t5.S.n;if(r4!==void 0&&(t5.r=r4),t5.S.n=t5,t5.i=-1,t5.n===void 0){i4.
s=t5;break}}}function _2(i4){for(var t5=i4.s,r4=void 0;t5!==void 0;){var n3=t5.p;t5.i===-1?(t5.S.U(t5),n3!==void 0&&(n3.n=t5.n),t5.n!==void 0&&(t5.n.p=n3)):r4=t5,
t5.S.n=t5.r,t5.r!==void 0&&(t5.r=void 0),t5=n3}i4.s=r4}function j2(i4,t5){l3.call(this,void 0,t5),this.x=i4,this.s=void 0,this.g=a3-1,this.f=4}j2.prototype=new l3;
j2.prototype.h=function(){if(this.f&=-3,1&this.f)return!1;if((36&this.f)==32||(this.f&=-5,this.g===a3))return!0;if(this.g=a3,this.f|=1,this.i>0&&!w3(this))return this.
f&=-2,!0;var i4=o3;try{b(this),o3=this;var t5=this.x();(16&this.f||this.v!==t5||this.i===0)&&(this.v=t5,this.f&=-17,this.i++)}catch(i5){this.v=i5,this.f|=16,this.
i++}return o3=i4,_2(this),this.f&=-2,!0};j2.prototype.S=function(i4){if(this.t===void 0){this.f|=36;for(var t5=this.s;t5!==void 0;t5=t5.n)t5.S.S(t5)}l3.prototype.
S.call(this,i4)};j2.prototype.U=function(i4){if(this.t!==void 0&&(l3.prototype.U.call(this,i4),this.t===void 0)){this.f&=-33;for(var t5=this.s;t5!==void 0;t5=t5.
n)t5.S.U(t5)}};j2.prototype.N=function(){if(!(2&this.f)){this.f|=6;for(var i4=this.t;i4!==void 0;i4=i4.x)i4.t.N()}};Object.defineProperty(j2.prototype,"value",{
get:function(){if(1&this.f)throw new Error("Cycle detected");var i4=d2(this);if(this.h(),i4!==void 0&&(i4.i=this.i),16&this.f)throw this.v;return this.v}});function O(i4,t5){
return new j2(i4,t5)}function p3(i4){var r4=i4.j;if(i4.j=void 0,typeof r4=="function"){v3++;var n3=o3;o3=void 0;try{r4()}catch(t5){throw i4.f&=-2,i4.f|=8,g3(i4),
t5}finally{o3=n3,t3()}}}function g3(i4){for(var t5=i4.s;t5!==void 0;t5=t5.n)t5.S.U(t5);i4.x=void 0,i4.s=void 0,p3(i4)}function S2(i4){if(o3!==this)throw new Error(
"Out-of-order effect");_2(this),o3=i4,this.f&=-2;try{8&this.f&&g3(this)}finally{t3()}}function m3(i4,t5){this.x=i4,this.j=void 0,this.s=void 0,this.u=void 0,this.
f=32,this.name=t5?.name,n2&&n2.push(this)}m3.prototype.c=function(){var i4=this.S();try{if(8&this.f||this.x===void 0)return;var t5=this.x();typeof t5=="function"&&
(this.j=t5)}finally{i4()}};m3.prototype.S=function(){if(1&this.f)throw new Error("Cycle detected");this.f|=1,this.f&=-9,p3(this),b(this),v3++;var i4=o3;return o3=
this,S2.bind(this,i4)};m3.prototype.N=function(){2&this.f||(this.f|=2,this.u=h3,h3=this)};m3.prototype.d=function(){this.f|=8,1&this.f||g3(this)};m3.prototype.dispose=
function(){this.d()};function x2(i4,t5){var r4=new m3(i4,t5);try{r4.c()}catch(i5){throw r4.d(),i5}var n3=r4.d.bind(r4);return n3[Symbol.dispose]=n3,n3}var h4,d3,p4,m4=typeof window<"u"&&!!window.__PREACT_SIGNALS_DEVTOOLS__;var g4=[];x2(function(){h4=this.N})();function b2(i4,n3){n[i4]=n3.bind(null,n[i4]||function(){})}function y4(i4){if(p4){var n3=p4;p4=void 0,n3()}p4=i4&&i4.S()}function w4(i4){
var n3=this,r4=i4.data,t5=useSignal(r4);t5.name="ReactiveDom",t5.value=r4;var e4=w2(function(){for(var i5=n3,r5=n3.__v;r5=r5.__;)if(r5.__c){r5.__c.__$f|=4;break}
var o5=O(function(){var i6=t5.value.value;return i6===0?0:i6===!0?"":i6||""}),e5=O(function(){return!Array.isArray(o5.value)&&!r(o5.value)}),u5=x2(function(){if(this.
N=M,e5.value){var n4=o5.value;i5.__v&&i5.__v.__e&&i5.__v.__e.nodeType===3&&(i5.__v.__e.data=n4)}}),c5=n3.__$u.d;return n3.__$u.d=function(){u5(),c5.call(this)},
[e5,o5]},[]),u4=e4[0],c4=e4[1];return u4.value?c4.peek():c4.value}w4.displayName="ReactiveTextNode";Object.defineProperties(l3.prototype,{constructor:{configurable:!0,
value:k($,null).constructor},type:{configurable:!0,value:w4},props:{configurable:!0,get:function(){var i4=this;return{data:{get value(){return i4.value}}}}},__b:{
configurable:!0,value:1}});b2("__b",function(i4,n3){if(y4(),d3=void 0,typeof n3.type=="string"){var r4,t5=n3.props;for(var f5 in t5)if(f5!=="children"){var o5=t5[f5];
o5 instanceof l3&&(r4||(n3.__np=r4={}),r4[f5]=o5,t5[f5]=o5.peek())}}i4(n3)});b2("__r",function(i4,r4){if(i4(r4),r4.type!==$){y4();var t5,f5=r4.__c;f5&&(f5.__$f&=
-2,(t5=f5.__$u)===void 0&&(f5.__$u=t5=(function(i5,n3){var r5;return x2(function(){r5=this},{name:n3}),r5.c=i5,r5})((function(i5){return function(){var n3;m4&&((n3=
this.y)==null||n3.call(this)),i5.__$f|=1,i5.setState({})}})(f5),typeof r4.type=="function"?r4.type.displayName||r4.type.name:""))),d3=f5,y4(t5)}});b2("__e",function(i4,n3,r4,t5){
y4(),d3=void 0,i4(n3,r4,t5)});b2("diffed",function(i4,n3){y4(),d3=void 0;var r4;if(typeof n3.type=="string"&&(r4=n3.__e)){var t5=n3.__np,f5=n3.props,o5=r4.U;if(o5)
for(var e4 in o5){var u4=o5[e4];u4===void 0||t5&&e4 in t5||(u4.d(),o5[e4]=void 0)}if(t5){o5||(o5={},r4.U=o5);for(var a5 in t5){var c4=o5[a5],v4=t5[a5];c4===void 0?
(c4=k3(r4,a5,v4,f5),o5[a5]=c4):c4.o(v4,f5)}}}i4(n3)});function k3(i4,n3,r4,t5){var f5=n3 in i4&&i4.ownerSVGElement===void 0,o5=y3(r4);return{o:function(i5,n4){o5.
value=i5,t5=n4},d:x2(function(){this.N=M;var r5=o5.value.value;t5[n3]!==r5&&(t5[n3]=r5,f5?i4[n3]=r5:r5!=null&&(r5!==!1||n3[4]==="-")?i4.setAttribute(n3,r5):i4.removeAttribute(
n3))})}}b2("unmount",function(i4,n3){if(typeof n3.type=="string"){var r4=n3.__e;if(r4){var t5=r4.U;if(t5){r4.U=void 0;for(var f5 in t5){var o5=t5[f5];o5&&o5.d()}}}
var e4=n3.__np;if(e4){var u4=n3.props;for(var a5 in e4)u4[a5]=e4[a5]}n3.__np=void 0}else{var c4=n3.__c;if(c4){c4.__$f|=8;var v4=c4.__$u;v4&&(c4.__$u=void 0,v4.d())}}
i4(n3)});b2("__h",function(i4,n3,r4,t5){t5<3&&(n3.__$f|=2),i4(n3,r4,t5)});x.prototype.shouldComponentUpdate=function(i4,n3){if(this.__R)return!0;var r4=this.__$u,
t5=r4&&r4.s!==void 0;for(var f5 in n3)return!0;if(this.__f||typeof this.u=="boolean"&&this.u===!0){var o5=2&this.__$f;if(!(t5||o5||4&this.__$f)||1&this.__$f)return!0}else if(!(t5||
4&this.__$f)||3&this.__$f)return!0;for(var e4 in i4)if(e4!=="__source"&&i4[e4]!==this.props[e4])return!0;for(var u4 in this.props)if(!(u4 in i4))return!0;return!1};
function useSignal(i4,n3){return w2(function(){return y3(i4,n3)},[])}var A3=function(i4){queueMicrotask(function(){queueMicrotask(i4)})};function F3(){r3(function(){for(var i4;i4=g4.shift();)h4.call(i4)})}function M(){g4.push(this)===1&&(n.requestAnimationFrame||A3)(F3)}var LOST_AFTER_MS=380,LOOK_EVERY_MS=50,CONNECT_AGAIN_MS=400,SILENT_MS=3e3,shown=y3(null),lost_for=y3(null),connection=y3(null),socket=null,greeted=null,seen_ms=0,
lost_listener=()=>{};function on_loss(listener){lost_listener=listener}function is_live(){return connection.value!==null&&performance.now()-drawn_at<=LOST_AFTER_MS}
function operate(act,step){return socket===null||socket.readyState!==WebSocket.OPEN||connection.value===null?!1:socket.bufferedAmount>2e3?(socket.close(),!1):(socket.
send(JSON.stringify({seen_ms,act,step})),!0)}var sequence=0,drawn_at=-1/0,received_at=performance.now(),least_offset=1/0;function drawn(of){drawn_at=Math.max(drawn_at,
performance.now()-of.late_ms),seen_ms=of.now_ms,look()}function changed(value,path,at2,to){if(at2===path.length)return to;let step=path[at2];if(Array.isArray(value)&&
typeof step=="number"&&step<value.length){let copy=value.slice();return copy[step]=changed(value[step],path,at2+1,to),copy}if(value!==null&&typeof value=="objec\
t"&&Object.hasOwn(value,step)){let from=value;return{...from,[step]:changed(from[step],path,at2+1,to)}}throw new Error("a change at a place that the page does n\
ot have")}function take(frame){let page=frame.page;if(page===void 0){if(shown.value===null||frame.sequence!==sequence+1)throw new Error("a frame was missed");page=
(frame.changes??[]).reduce((page2,[path,to])=>changed(page2,path,0,to),shown.value.page)}sequence=frame.sequence;let offset=performance.now()-frame.now_ms;least_offset=
Math.min(least_offset,offset);let late_ms=offset-least_offset;late_ms<LOST_AFTER_MS&&(received_at=performance.now()),shown.value={page,now_ms:frame.now_ms,late_ms},
connection.value=greeted}function connect(){let opened=new WebSocket(`ws://${location.host}/feed`);socket=opened,received_at=performance.now(),least_offset=1/0;
let silent=setInterval(()=>{performance.now()-received_at>SILENT_MS&&opened.close()},CONNECT_AGAIN_MS);opened.onmessage=event=>{try{let message=JSON.parse(event.
data);if("connection"in message){greeted=message.connection;return}take(message),opened.send(String(sequence))}catch(error){console.error(error),opened.close()}},
opened.onclose=()=>{connection.value=greeted=null,lost_listener(),clearInterval(silent),setTimeout(connect,CONNECT_AGAIN_MS)}}function look(){let age=performance.
now()-drawn_at,is_lost=age>LOST_AFTER_MS;document.documentElement.classList.toggle("lost",is_lost),is_lost&&lost_for.value===null&&lost_listener(),lost_for.value=
is_lost?Math.floor(age/100)*100:null}function begin(){setInterval(look,LOOK_EVERY_MS),document.addEventListener("visibilitychange",look),connect()}var t4={overview:"Overview",chart:"Chart",alarms:"Alarms",cell:"Cell",waiting:"Waiting",pages:"Pages",mode:"Mode",unknown:"unknown",not_all:"not acknowledged by",
left_out:"Left out",restarted:"Restarted",next:"Next step of recovery",all_steps:"all: linewright recover",cycle:"Last cycle, standstill in it included",no_cycle:"\
none yet",count:"Cycle",alarms_none:"no alarms",more_alarms:count=>count===1?"1 alarm":`${count} alarms`,priority:"Priority",state:"State",source:"From",age:"Ag\
e",text:"What has happened, and what to do",answers:"Answers",lead:"Before the answer, lead to a rest by hand",way:"Which way",reset:"First reset",at_order:"Sti\
ll at its order",bring:(station,rest)=>`Before the answer, bring ${station} to ${rest} in hand mode`,parts:"Parts",inside:(inside,left)=>`${inside} inside, ${left}\
 have left`,nothing_starts:"nothing starts",in_progress:"In progress",failed:"failed",orders:"Orders",open:count=>`${count} not over`,out_of_service:"Out of ser\
vice",part:"Part",stage:"Stage",place:"Place",order:"Order",none:"none",waits_for:"Waits for",waits_for_nothing:"waits for nothing",ago:seconds=>`−${seconds} \
s`,now:"now",last_frame:"last frame",window:"Time shown",seconds:seconds=>`${seconds} s`,legend:"Legend",at_rest:"at rest",lost:seconds=>`No connection to the c\
onsole for ${seconds} s. Values that are struck through are from before.`,never:"No connection to the console yet.",operate:"Operate",no_safety:"No button of th\
is page is a safety function, and none is an emergency stop device.",control_none:"Control: nobody. All pages read.",control_own:since=>`Control: this page, for\
 ${since}`,control_other:(name2,since)=>`Control: ${name2}, for ${since}. This page reads.`,control_taken:name2=>`Control was taken over by ${name2}. This page \
reads.`,control_gone:"This page had control, and has it no more.",pressed:button2=>`${button2} is held`,your_name:"Your name",take:"Take control",take_over:"Tak\
e control over",give_up:"Give control up",read:"Read",no_control:"this page has no control; take it first (in the head of the page)",not_live:"the page shows wh\
at is of before; nothing is given",hold_it:"hold",is_held:"held",console_buttons:"Buttons of the console",selector:manual=>`selector at ${manual?"manual":"auto"}`,
selector_unknown:"selector unknown",plan:"The way back to auto",no_next:"no step that has a button here",since:why=>`since ${why}`,stands:how=>`if it stands so:\
 ${how}`,choose:"choose…",alarm:"Alarm",note:"Note",acknowledge:"Acknowledge (seen)",acknowledged:of=>`${of.by}, ${of.age} ago${of.note&&`: ${of.note}`}`,choose_alarm:"\
choose the alarm first",answer:"Answer",give_answer:"Give the answer",choose_answer:"choose an alarm of the cell and its answer first",order_new:"New order",product:"\
Product",quantity:"Number of parts",order_name:"Name (optional)",due_minutes:"Due in minutes (optional)",submit:"Submit the order",choose_product:"choose the pr\
oduct and a whole number of parts first",order_or_resource:"An order, or a resource",resource:"Resource",why:about=>about===void 0?"Why not?":`Why not? (${about}\
)`,cancel:"Cancel the order",withdraw:"Withdraw the order",choose_order:"choose an order first",choose_order_or_resource:"choose an order or a resource first",down:"\
Take out of service",up:"Back into service",reset_resource:"Reset its station",choose_resource:"choose a resource first",ended_stalled:"released: the page was t\
oo busy; hold it again",ended_lost:"released: no connection to the console; hold it again when it is back",ended_away:"released: the page was left; hold it agai\
n",ended_control:"released: this page has no control any more",ended_left:"released: the pointer has left the button; hold it again",ended_second:"released: som\
ething else was touched meanwhile; let go, then hold it again",ended_cancelled:"released: the browser has taken the pointer; hold it again"},health={unknown:"un\
known",emergency_stop:"emergency stop",fault:"fault",left_out:"left out",not_ready:"not ready",manual:"manual",ok:"ready"},kinds={moving:"under way",undoing:"un\
der way back",halted:"begun, stands",stopped:"stopped before its end",unknown:"unknown"},command_labels={estop:"all outputs off — no safety function"};var f4=Symbol.for("pv"),o4=0;function a4(t5,e4,n3,u4,a5,i4){e4||(e4={});var c4,l4,p5=e4;if("ref"in p5&&typeof t5!="function")for(l4 in p5={},e4)l4=="ref"?c4=e4[l4]:p5[l4]=e4[l4];var s4={type:t5,
props:p5,key:n3,ref:c4,__k:null,__:null,__b:0,__e:null,__c:null,constructor:f4,__v:--o4,__i:-1,__u:0};return(a5||i4)&&(s4.__source=a5,s4.__self=i4),n.vnode&&n.vnode(
s4),s4}var WINDOWS_S=[12,30,60,120],WIDTH=1e3,HEIGHT=18,window_s=y3(30);function bar(stretch,now_ms,span_ms){let x3=at2=>WIDTH*(1-(now_ms-at2)/span_ms),from=Math.max(0,
x3(stretch.from_ms)),to=x3(stretch.to_ms??now_ms);return to<=0?null:a4("rect",{class:`bar ${stretch.kind}`,x:from,y:"2",width:Math.max(to-from,1),height:HEIGHT-
4},stretch.from_ms)}function LaneRow({lane,shown:shown2}){let newest=lane.stretches.at(-1),kind=newest&&newest.to_ms===null?kinds[newest.kind]:t4.at_rest;return a4(
"tr",{children:[a4("th",{scope:"row",children:lane.operation}),a4("td",{class:"value word",children:kind}),a4("td",{class:"lane",children:a4("svg",{viewBox:`0 0\
 ${WIDTH} ${HEIGHT}`,preserveAspectRatio:"none","aria-hidden":"true",children:lane.stretches.map(stretch=>bar(stretch,shown2.now_ms,window_s.value*1e3))})})]})}
function Legend(){let all=Object.keys(kinds);return a4("p",{class:"legend","aria-label":t4.legend,children:all.map(kind=>a4("span",{children:[a4("svg",{viewBox:"\
0 0 24 14","aria-hidden":"true",children:a4("rect",{class:`bar ${kind}`,width:"24",height:"14"})}),kinds[kind]]},kind))})}function Chart({shown:shown2}){return a4(
"section",{children:[a4("svg",{class:"defs","aria-hidden":"true",children:a4("defs",{children:a4("pattern",{id:"hatch",width:"8",height:"8",patternUnits:"userSp\
aceOnUse",patternTransform:"rotate(45)",children:[a4("rect",{class:"hatch-ground",width:"8",height:"8"}),a4("rect",{class:"hatch-line",width:"3",height:"8"})]})})}),
a4("fieldset",{class:"choice",children:[a4("legend",{children:t4.window}),WINDOWS_S.map(seconds=>a4("button",{"aria-pressed":window_s.value===seconds,onClick:()=>window_s.
value=seconds,children:t4.seconds(seconds)},seconds))]}),a4(Legend,{}),shown2.page.lanes.map(of=>a4("table",{class:"lanes",children:[a4("caption",{children:of.label}),
a4("tbody",{children:of.lanes.map((lane,at2)=>a4(LaneRow,{lane,shown:shown2},at2))}),a4("tfoot",{children:a4("tr",{children:[a4("td",{colSpan:2}),a4("td",{class:"\
axis",children:[a4("span",{children:t4.ago(window_s.value)}),a4("span",{children:lost_for.value===null?t4.now:t4.last_frame})]})]})})]},of.station))]})}var BEAT_MS=100,STALLED_MS=250,last=0,hold=null,held=y3(null),ended=y3(null);function is_inside(of){if(!of.element.isConnected||of.element.dataset.key!==of.key)
return!1;if(of.pointer===null)return document.activeElement===of.element;let at2=document.elementFromPoint(of.pointer.x,of.pointer.y);return at2!==null&&of.element.
contains(at2)}function beat(){if(hold===null)return;let now=performance.now(),page=shown.value?.page,note=page?.control.notes[hold.connection];now-hold.beat_at>
STALLED_MS?end(t4.ended_stalled):!is_live()||hold.connection!==connection.value?end(t4.ended_lost):document.hidden||!document.hasFocus()?end(t4.ended_away):page?.
control.holder?.connection!==connection.value?end(t4.ended_control):note?.press===hold.number?end(note.text):is_inside(hold)?(hold.beat_at=now,operate({beat:{number:hold.
number}})||end(t4.ended_lost)):end(t4.ended_left)}function begin2(of,element,pointer){let{key,act,step}=of;if(hold!==null)return end(t4.ended_second);if(!("pres\
s"in act))return;last+=1;let is_sent=is_live()&&operate({press:{...act.press,number:last}},step);ended.value=is_sent?null:{key,why:t4.ended_lost},!(!is_sent||connection.
value===null)&&(hold={key,number:last,connection:connection.value,element,pointer,timer:setInterval(beat,BEAT_MS),beat_at:performance.now()},held.value=key)}function end(why){
if(hold===null)return;let{key,number,timer}=hold;clearInterval(timer),hold=null,held.value=null,why!==null&&(ended.value={key,why}),operate({release:{number}})}
function holds(of,may,refuse){return{onPointerDown:event=>{if(event.preventDefault(),!event.isPrimary||event.button!==0)return end(t4.ended_second);let element=event.
currentTarget;if(element.focus(),!may)return refuse();begin2(of,element,{id:event.pointerId,x:event.clientX,y:event.clientY})},onKeyDown:event=>{if(event.code!==
"Space"){hold!==null&&hold.pointer===null&&end(t4.ended_second);return}if(event.preventDefault(),!(event.repeat||event.ctrlKey||event.altKey||event.metaKey)){if(!may)
return refuse();begin2(of,event.currentTarget,null)}},onContextMenu:event=>event.preventDefault(),onClick:event=>event.preventDefault()}}function watch_holds(){
let on=(name2,end_of)=>addEventListener(name2,event=>hold?.pointer&&end_of(event),{capture:!0});on("pointermove",event=>{let at2=hold.pointer;event.pointerId===
at2.id&&([at2.x,at2.y]=[event.clientX,event.clientY],event.buttons!==1?end(event.buttons===0?null:t4.ended_second):is_inside(hold)||end(t4.ended_left))});for(let name2 of[
"pointerup","pointercancel"])on(name2,event=>event.pointerId===hold.pointer.id&&end(name2==="pointerup"?null:t4.ended_cancelled));let second=event=>{hold!==null&&
(end(t4.ended_second),event.stopPropagation())};addEventListener("pointerdown",second,{capture:!0}),document.documentElement.addEventListener("pointerleave",()=>hold?.
pointer&&end(t4.ended_left)),addEventListener("keyup",event=>event.code==="Space"&&hold!==null&&hold.pointer===null&&end(null),{capture:!0}),addEventListener("k\
eydown",event=>hold!==null&&hold.pointer!==null&&(second(event),event.preventDefault()),{capture:!0}),addEventListener("blur",()=>end(t4.ended_away)),addEventListener(
"pagehide",()=>end(t4.ended_away)),document.addEventListener("visibilitychange",()=>document.hidden&&end(t4.ended_away)),document.addEventListener("focusout",event=>hold!==
null&&event.target===hold.element&&end(t4.ended_left)),on_loss(()=>end(t4.ended_lost))}var SHAPES={1:"M1 1h18v18H1z",2:"M10 1 19 19H1z",3:"M1 1h18L10 19z"};function Priority({of,text}){return a4("span",{class:"priority",children:[a4("svg",{viewBox:"\
0 0 20 20",class:`p${of}`,"aria-hidden":"true",children:[a4("path",{d:SHAPES[of]}),a4("text",{x:"10",y:of===3?11:15.5,"text-anchor":"middle",children:of})]}),text]})}
function HealthSign({of}){return a4("span",{class:`health ${of} value`,children:health[of]})}function List({of}){return a4("ul",{children:of.map((text,at2)=>a4(
"li",{class:"value",children:text},at2))})}function Heads({of}){return a4("thead",{children:a4("tr",{children:of.map(head=>a4("th",{scope:"col",children:head},head))})})}
function Named({head,of}){return of.length>0?a4("p",{class:"value",children:`${head}: ${of.join(", ")}`}):null}var asked=y3(null),name=y3("");function has_control(page){return page.control.holder!==null&&page.control.holder.connection===connection.value}var is_stop=act=>"\
command"in act&&act.command.word==="estop";function why_not(page,button2){return is_stop(button2.act)?button2.why_not:lost_for.value!==null?t4.not_live:"why"in button2.
act||has_control(page)?button2.why_not:t4.no_control}function refused_as({act,label}){return"command"in act?[act.command.word,act.command.station].filter(Boolean).
join(" "):"press"in act&&act.press.station===void 0?label==="resume"?"resume":"buttons":null}function remark(page,button2){let note=page.control.notes[connection.
value??0];if(ended.value?.key===button2.key)return ended.value.why;if(note?.key===button2.key)return note.text;let word=refused_as(button2);return word!==null&&
word===page.mode.refused?page.mode.refusal:asked.value?.key===button2.key&&asked.value.why===why_not(page,button2)?asked.value.why:null}function ActButton({page,
button:button2,step}){let why=why_not(page,button2),refuse=()=>asked.value=why===null?null:{key:button2.key,why},is_hold="press"in button2.act,handlers=is_hold?
holds({key:button2.key,act:button2.act,step},why===null,refuse):{onClick:()=>{refuse(),ended.value=null,why===null&&operate(button2.act,step)}},label="command"in
button2.act&&button2.act.command.station===void 0?command_labels[button2.label]??button2.label:button2.label,is_held=held.value===button2.key;return a4("button",
{type:"button",class:`${is_hold?"hold":""} ${is_stop(button2.act)?"stop":""} ${is_held?"is-held":""}`,"aria-disabled":why!==null,"aria-pressed":is_hold?is_held:
void 0,"data-key":button2.key,...handlers,children:[label,is_hold&&a4("small",{children:is_held?t4.is_held:t4.hold_it})]})}function Acts({page,of,step}){let remarked=of.
map(button2=>[button2.label,remark(page,button2)]).find(([,text])=>text!==null);return a4($,{children:[a4("div",{class:"acts",children:of.map(button2=>a4(ActButton,
{page,button:button2,step},step===void 0?`${button2.key} ${button2.label}`:"next step"))}),a4("p",{class:"remark",role:"status",children:remarked&&`${remarked[0]}\
: ${remarked[1]}`})]})}function Control({page}){let{holder,press,notes}=page.control,is_own=has_control(page),note=notes[connection.value??0],refused=note?.key===
"control"?note.text:null;return a4("div",{class:is_own?"control own":"control",id:"control",children:[a4("span",{class:"value",children:[holder===null?t4.control_none:
is_own?t4.control_own(holder.since):t4.control_other(holder.name,holder.since),press!==null&&` · ${t4.pressed(press.button)}`]}),!is_own&&a4("input",{"aria-lab\
el":t4.your_name,placeholder:t4.your_name,maxLength:40,value:name.value,onInput:event=>name.value=event.target.value}),a4("button",{type:"button","data-key":"co\
ntrol",onClick:()=>operate(is_own?{give_up:{}}:{take:{name:name.value}}),children:is_own?t4.give_up:holder===null?t4.take:t4.take_over}),refused!==null&&a4("spa\
n",{class:"remark",role:"status",children:refused})]})}function Plan({page}){let{plan}=page;return a4("section",{class:"plan",children:[a4("h2",{children:t4.plan}),
a4("div",{class:"next-step",children:plan?.button?a4(Acts,{page,of:[plan.button],step:plan.step}):a4("p",{children:t4.no_next})}),plan!==null&&a4("div",{class:"\
steps",tabIndex:0,children:[a4(List,{of:plan.begin}),a4("ol",{children:plan.steps.map((step,at2)=>a4("li",{class:at2===plan.next?"value next":"value","aria-curr\
ent":at2===plan.next?"step":void 0,children:[step.text,step.since!==null&&a4("p",{children:t4.since(step.since)}),a4(List,{of:step.stands.map(t4.stands)})]},at2))}),
a4(List,{of:plan.end})]})]})}function Operate({page}){let{commands,hand,resume,panels}=page.operate;return a4($,{children:[a4("p",{class:page.mode.is_known?"val\
ue text fixed":"value text fixed is-unknown",children:page.mode.text}),a4(Acts,{page,of:commands}),a4(Plan,{page}),a4("section",{children:[a4("h2",{children:t4.
console_buttons}),a4(Acts,{page,of:[...hand,resume]})]}),panels.map((panel,at2)=>{let station=page.stations[at2];return a4("section",{children:[a4("h2",{children:[
panel.station," ",station&&a4(HealthSign,{of:station.health})]}),a4(Acts,{page,of:[...panel.holds,...panel.selects]}),a4("div",{class:"fixed",children:[station&&
a4("p",{class:station.moves?"value moves":"value",children:station.unknown??station.operation}),station?.fault&&a4("p",{class:"value fault-text",children:station.
fault}),a4("p",{class:"value",children:panel.is_manual===null?t4.selector_unknown:t4.selector(panel.is_manual)}),station&&station.waits_for.length>0&&a4($,{children:[
a4("p",{children:[t4.waits_for,":"]}),a4(List,{of:station.waits_for})]})]})]},panel.station)})]})}var chosen=y3({}),choose=(name2,value)=>chosen.value={...chosen.value,[name2]:value},choice=name2=>chosen.value[name2]??"";function Choice({name:name2,label,of}){
let value=of.some(([value2])=>value2===choice(name2))?choice(name2):"";return a4("label",{class:"choose",children:[label,a4("select",{value,"data-choice":name2,
onChange:event=>choose(name2,event.target.value),children:[a4("option",{value:"",children:t4.choose}),of.map(([value2,text])=>a4("option",{value:value2,children:text},
value2))]})]})}function Entry({name:name2,label,type,max}){return a4("label",{class:"choose",children:[label,a4("input",{type:"text",inputMode:type==="number"?"\
numeric":"text",maxLength:max,value:choice(name2),"data-choice":name2,onInput:event=>choose(name2,event.target.value)})]})}function whole(text){return/^\d{1,9}$/.
test(text)?Number(text):null}function button(key,label,act,missing){return{key,label,act:act??{give_up:{}},why_not:act===null?missing:null}}var cut=text=>text.length>
70?`${text.slice(0,69)}…`:text;function AlarmForms({page}){let alarm=page.alarms.find(of=>String(of.shown)===choice("alarm")),answer_to=`answer to ${alarm?.shown??
""}`,answer=alarm?.answers.find(of=>of.answer===choice(answer_to)),acknowledge=alarm===void 0?null:{acknowledge:{shown:alarm.shown,note:choice("note")}},answered=alarm?.
number==null||answer===void 0?null:{answer:{alarm:alarm.number,word:answer.answer}};return a4("section",{class:"forms",children:[a4(Choice,{name:"alarm",label:t4.
alarm,of:page.alarms.map(of=>[String(of.shown),cut(`${of.source}: ${of.text}`)])}),a4(Entry,{name:"note",label:t4.note,type:"text",max:100}),a4(Acts,{page,of:[button(
"acknowledge",t4.acknowledge,acknowledge,t4.choose_alarm)]}),page.is_cell&&a4($,{children:[a4(Choice,{name:answer_to,label:t4.answer,of:(alarm?.answers??[]).map(
of=>[of.answer,of.answer])}),a4("p",{class:"value fixed",id:"chosen-answer",children:answer&&[answer.meaning,answer.verdict,answer.why].filter(Boolean).join("; ")}),
a4(Acts,{page,of:[button("answer",t4.give_answer,answered,t4.choose_answer)]})]})]})}function CellForms({page,cell}){let product=cell.products.find(of=>of===choice(
"product")),[quantity,due]=[whole(choice("quantity")),whole(choice("due"))],due_s=due===null?void 0:due*60,is_due_read=due!==null||choice("due")==="",submitted=product===
void 0||quantity===null||!is_due_read?null:{submit:{product,quantity,name:choice("order name"),due_s}},open=cell.orders.filter(of=>!of.is_over),order=open.find(
of=>of.name===choice("order"))?.name,resource=cell.resources.find(of=>of===choice("resource")),about=order??resource,of_resource=to=>resource===void 0?null:{resource:{
resource,to}};return a4("section",{class:"forms",children:[a4("h2",{children:t4.order_new}),a4(Choice,{name:"product",label:t4.product,of:cell.products.map(of=>[
of,of])}),a4(Entry,{name:"quantity",label:t4.quantity,type:"number",max:9}),a4(Entry,{name:"order name",label:t4.order_name,type:"text",max:60}),a4(Entry,{name:"\
due",label:t4.due_minutes,type:"number",max:9}),a4(Acts,{page,of:[button("submit",t4.submit,submitted,t4.choose_product)]}),a4("h2",{children:t4.order_or_resource}),
a4(Choice,{name:"order",label:t4.order,of:open.map(of=>[of.name,of.name])}),a4(Choice,{name:"resource",label:t4.resource,of:cell.resources.map(of=>[of,of])}),a4(
Acts,{page,of:[button("why",t4.why(about),about===void 0?null:{why:{about}},t4.choose_order_or_resource)]}),a4(Acts,{page,of:[button("cancel",t4.cancel,order===
void 0?null:{cancel:{order}},t4.choose_order),button("withdraw",t4.withdraw,order===void 0?null:{withdraw:{order}},t4.choose_order)]}),a4(Acts,{page,of:[button(
"resource down",t4.down,of_resource("down"),t4.choose_resource),button("resource up",t4.up,of_resource("up"),t4.choose_resource),button("resource reset",t4.reset_resource,
of_resource("reset"),t4.choose_resource)]})]})}function ModeBlock({page}){let{mode}=page;return a4("section",{class:"mode","aria-label":t4.mode,children:[a4("p",{class:mode.is_known?"value text":"value text \
is-unknown",children:mode.text}),mode.is_enabled===!1&&a4(Named,{head:t4.not_all,of:mode.waiting_for}),mode.refusal&&a4("p",{class:"value",children:mode.refusal}),
a4(Named,{head:t4.left_out,of:mode.left_out}),a4(Named,{head:t4.restarted,of:mode.restarted}),mode.is_known&&!page.is_cell&&a4("p",{children:[t4.cycle,": ",a4("\
span",{class:"value",children:mode.cycle?`${mode.cycle.duration_s.toFixed(1)} s (${mode.cycle.number})`:t4.no_cycle})]}),page.next&&a4("p",{class:"next",children:[
t4.next,": ",a4("span",{class:"value",children:page.next})," (",t4.all_steps,")"]})]})}function StationCard({station}){return a4("li",{class:`card ${station.health}`,
children:[a4("h3",{children:[station.label," ",a4(HealthSign,{of:station.health})]}),station.unknown!==null?a4("p",{class:"value",children:station.unknown}):a4(
$,{children:[a4("p",{class:station.moves?"value moves":"value",children:station.operation}),a4("p",{children:[t4.mode,": ",a4("span",{class:"value",children:station.
mode})," · ",t4.count,": ",a4("span",{class:"value",children:station.cycle})]}),station.notes.map((note,at2)=>a4("p",{class:"value",children:note},at2)),station.
fault&&a4("p",{class:"value fault-text",children:station.fault})]})]})}function Overview({page}){let open=page.cell?.orders.filter(order=>!order.is_over)??[];return a4(
$,{children:[a4(ModeBlock,{page}),page.other_descriptions.length>0&&a4(List,{of:page.other_descriptions}),a4("ul",{class:"cards",children:page.stations.map(station=>a4(
StationCard,{station},station.name))}),page.is_cell&&a4("section",{children:[a4("h2",{children:t4.orders}),page.cell_unknown?a4("p",{class:"value is-unknown",children:page.
cell_unknown}):a4(Orders,{orders:open})]})]})}function Orders({orders}){return orders.length===0?a4("p",{class:"value",children:t4.none}):a4("ul",{children:orders.
map(order=>a4("li",{class:order.is_late?"value late":"value",children:[order.name,": ",order.text,order.due&&`, ${order.due}`]},order.id))})}function AlarmRow({
alarm}){return a4("tr",{children:[a4("td",{children:a4(Priority,{of:alarm.priority,text:alarm.priority_text})}),a4("td",{class:"value",children:[alarm.state,alarm.
acknowledged&&a4("p",{children:t4.acknowledged(alarm.acknowledged)})]}),a4("td",{class:"value",children:alarm.number===null?alarm.source:`${alarm.source}, ${alarm.
number}`}),a4("td",{class:"value",children:alarm.age}),a4("td",{children:[a4("p",{class:"value",children:alarm.text}),a4(Named,{head:t4.at_order,of:alarm.at_order}),
a4(Named,{head:t4.reset,of:alarm.reset}),a4(Named,{head:t4.lead,of:alarm.lead}),alarm.lead_to&&a4("p",{class:"value",children:`${t4.way}: ${alarm.lead_to}${alarm.
lead_because&&` (${alarm.lead_because})`}`}),alarm.bring&&a4("p",{class:"value",children:t4.bring(...alarm.bring)}),alarm.answers.length>0&&a4("p",{children:[t4.
answers,":"]}),a4("ul",{children:alarm.answers.map(of=>a4("li",{class:"value",children:[a4("strong",{children:of.answer}),[of.meaning,of.verdict,of.why].filter(
Boolean).map(text=>`; ${text}`)]},of.answer))})]})]})}function Alarms({page}){return a4($,{children:[a4(AlarmForms,{page}),page.alarms.length===0?a4("p",{class:"\
value",children:t4.alarms_none}):a4("table",{class:"list",children:[a4(Heads,{of:[t4.priority,t4.state,t4.source,t4.age,t4.text]}),a4("tbody",{children:page.alarms.
map(alarm=>a4(AlarmRow,{alarm},alarm.key))})]})]})}function Cell({page}){let cell=page.cell;return cell===null?a4("p",{class:"value is-unknown",children:page.cell_unknown}):
a4($,{children:[a4(CellForms,{page,cell}),a4("section",{children:[a4("h2",{children:t4.in_progress}),cell.activities.length===0&&a4("p",{class:"value",children:t4.
none}),a4(List,{of:cell.activities.map(of=>`${of.name}${of.part===null?"":`, ${t4.part} ${of.part}`}, ${of.age}${of.running?"":`, ${t4.failed}`}${of.text&&`: ${of.
text}`}`)})]}),a4("section",{children:[a4("h2",{children:[t4.parts,": ",a4("span",{class:"value",children:t4.inside(cell.parts_inside,cell.parts_left)}),!cell.starting&&
a4("span",{class:"value",children:["; ",t4.nothing_starts]})]}),a4("table",{class:"list",children:[a4(Heads,{of:[t4.part,t4.stage,t4.order,t4.place,t4.age]}),a4(
"tbody",{children:cell.parts.map(part=>a4("tr",{children:[part.part,part.stage,part.order??"",part.place,part.age].map((text,at2)=>a4("td",{class:"value",children:text},
at2))},part.part))})]})]}),a4("section",{children:[a4("h2",{children:[t4.orders,": ",a4("span",{class:"value",children:t4.open(cell.orders_open)})]}),a4(Orders,
{orders:cell.orders})]}),a4("section",{children:[a4("h2",{children:t4.out_of_service}),cell.out_of_service.length===0?a4("p",{class:"value",children:t4.none}):a4(
List,{of:cell.out_of_service.map(of=>of.text)})]})]})}function Waiting({page}){return a4($,{children:[a4(ModeBlock,{page}),page.stations.map(station=>a4("sectio\
n",{children:[a4("h2",{children:[station.label," ",a4(HealthSign,{of:station.health})]}),station.unknown!==null&&a4("p",{class:"value is-unknown",children:station.
unknown}),station.fault&&a4("p",{class:"value fault-text",children:station.fault}),station.unknown===null&&station.waits_for.length===0&&a4("p",{class:"value",children:t4.
waits_for_nothing}),station.waits_for.length>0&&a4("p",{children:[t4.waits_for,":"]}),a4(List,{of:station.waits_for})]},station.name))]})}var names=["overview","operate","chart","alarms","cell","waiting"],here=()=>names.find(name2=>`#${name2}`===location.hash)??"overview",at=y3(here());addEventListener(
"hashchange",()=>at.value=here());function Banner({page}){let first=page.alarms[0];return first===void 0?a4("p",{class:"banner none value",children:t4.alarms_none}):
a4("a",{class:"banner",href:"#alarms",children:[a4(Priority,{of:first.priority,text:first.priority_text}),a4("span",{class:"value what",children:`${first.source}\
: ${first.text}`}),a4("span",{class:"value",children:t4.more_alarms(page.alarms.length)})]})}var had_control=y3(!1),lost_control=y3(!1);function Taken({page}){let has=has_control(
page);return F2(()=>{has?lost_control.value=!1:had_control.value&&page.control.holder!==null&&(lost_control.value=!0),had_control.value=has},[has,page.control.holder?.
connection]),has||!lost_control.value?null:a4("p",{class:"taken",role:"alert",children:[page.control.holder===null?t4.control_gone:t4.control_taken(page.control.
holder.name)," ",a4("button",{type:"button",onClick:()=>lost_control.value=!1,children:t4.read})]})}function Lost(){let age=lost_for.value;if(age===null)return null;
let text=shown.value===null?t4.never:t4.lost((age/1e3).toFixed(1));return a4("div",{id:"lost",role:"alert",children:text})}function Body(){let now=shown.value;if(F2(
()=>{now!==null&&drawn(now)},[now]),now===null)return null;let page=now.page,name2=at.value==="cell"&&!page.is_cell?"overview":at.value;return a4($,{children:[a4(
"header",{children:[a4("div",{class:"title",children:[a4("h1",{children:page.title}),a4("p",{children:[t4.mode,":"," ",a4("strong",{id:"mode",class:page.mode.is_known?
"value":"value is-unknown",children:page.mode.is_known?page.mode.word:t4.unknown})]})]}),a4("nav",{"aria-label":t4.pages,children:names.filter(name3=>name3!=="c\
ell"||page.is_cell).map(of=>a4("a",{href:`#${of}`,"aria-current":of===name2?"page":void 0,children:t4[of]},of))}),a4(Banner,{page}),a4(Control,{page}),a4(Taken,
{page})]}),a4("main",{children:[name2==="overview"&&a4(Overview,{page}),name2==="operate"&&a4(Operate,{page}),name2==="chart"&&a4(Chart,{shown:now}),name2==="al\
arms"&&a4(Alarms,{page}),name2==="cell"&&a4(Cell,{page}),name2==="waiting"&&a4(Waiting,{page})]}),a4("footer",{children:t4.no_safety})]})}Q(a4($,{children:[a4(Body,
{}),a4(Lost,{})]}),document.getElementById("page"));watch_holds();begin();
